"""The inertia of a rigid body: ten numbers, and which ten numbers a real body can have.

About the origin of a frame, mass m, first moment h = m c and moments of inertia I are linear in
everything that a force sensor measures:

    phi = [m, h_x, h_y, h_z, I_xx, I_xy, I_yy, I_xz, I_yz, I_zz].

A distribution of positive mass has a positive definite pseudo-inertia (Wensing, Kim and Slotine
2018, "Linear matrix inequalities for physically consistent inertial parameter identification"),

    P = [[S, h], [h^T, m]],   S = tr(I)/2 1 - I,   I = tr(S) 1 - S,

and each positive definite P is a distribution of mass. All of them, and nothing else, are reached
by ten free numbers eta through a triangular root (Rucker and Wensing 2022, "Smooth parameterization
of rigid-body inertia"):

    P = U U^T,   U = e^alpha [[e^d1, s12, s13, t1], [0, e^d2, s23, t2], [0, 0, e^d3, t3], [0 0 0 1]]
    eta = [alpha, d1, d2, d3, s12, s23, s13, t1, t2, t3].

m = e^(2 alpha) and the centre of mass is t.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bodyschema.errors import InputError
from bodyschema.model.kernels import kernel

Array = NDArray[np.float64]

PHI = ("m", "h_x", "h_y", "h_z", "I_xx", "I_xy", "I_yy", "I_xz", "I_yz", "I_zz")
"""Names of the ten parameters, in their order."""

_ROWS, _COLUMNS = np.array([0, 0, 1, 0, 1, 2]), np.array([0, 1, 1, 2, 2, 2])


@dataclass(frozen=True)
class Inertia:
    """Mass, its centre, and the moments about that centre, all in one frame."""

    mass: float
    """kg."""
    com: Array
    """(3,) m, centre of mass."""
    moments: Array
    """(3, 3) kg m^2, about the centre of mass, along the frame's axes."""

    @classmethod
    def from_phi(cls, phi: ArrayLike) -> Inertia:
        """Of the ten parameters about the origin.

        Raises:
            InputError: they are not ten finite numbers, or the mass is zero.
        """
        p = np.asarray(phi, dtype=np.float64)
        if p.shape != (10,) or not np.isfinite(p).all() or p[0] == 0:
            raise InputError(
                f"inertial parameters are ten finite numbers {', '.join(PHI)} with a mass that is "
                f"not zero; got {np.array2string(p, precision=4)}."
            )
        com = p[1:4] / p[0]
        return cls(float(p[0]), com, symmetric(p[4:]) - about_origin(p[0], com))

    @property
    def phi(self) -> Array:
        """(10,) about the origin."""
        about = self.moments + about_origin(self.mass, self.com)
        return np.array([self.mass, *(self.mass * self.com), *about[_ROWS, _COLUMNS]])

    @property
    def physical(self) -> bool:
        """Whether some distribution of positive mass has this inertia."""
        return is_physical(self.phi)

    def in_frame(self, T_b_a: ArrayLike) -> Inertia:
        """The same body in frame b, where this is frame a: T_b_a is (4, 4)."""
        T = np.asarray(T_b_a, dtype=np.float64)
        R, t = T[:3, :3], T[:3, 3]
        return Inertia(self.mass, R @ self.com + t, R @ self.moments @ R.T)

    def principal(self) -> tuple[Array, Array]:
        """Moments (3,) about the centre, smallest first, and their axes, right-handed columns."""
        values, axes = np.linalg.eigh(self.moments)
        # Signs are free: the largest entry of the first two axes is made positive.
        for k in (0, 1):
            axes[:, k] *= np.sign(axes[np.argmax(np.abs(axes[:, k])), k])
        axes[:, 2] = np.cross(axes[:, 0], axes[:, 1])
        return values, axes


def symmetric(six: Array) -> Array:
    """(3, 3) of xx, xy, yy, xz, yz, zz."""
    out = np.empty((3, 3))
    out[_ROWS, _COLUMNS] = out[_COLUMNS, _ROWS] = six
    return out


def about_origin(mass: float, com: Array) -> Array:
    """(3, 3) what a mass point adds to the moments about the origin: m (c.c 1 - c c^T)."""
    return np.asarray(mass * (float(com @ com) * np.eye(3) - np.outer(com, com)))


def pseudo_inertia(phi: Array) -> Array:
    """P of the module's text: (10,) -> (4, 4)."""
    about = symmetric(phi[4:])
    P = np.empty((4, 4))
    P[:3, :3] = np.trace(about) / 2 * np.eye(3) - about
    P[:3, 3] = P[3, :3] = phi[1:4]
    P[3, 3] = phi[0]
    return P


def phi_of_pseudo(P: Array) -> Array:
    """The inverse of `pseudo_inertia`; linear: (*batch, 4, 4) -> (*batch, 10)."""
    S = P[..., :3, :3]
    trace = np.trace(S, axis1=-2, axis2=-1)[..., None, None]
    about = trace * np.eye(3) - S
    return np.concatenate([P[..., 3, 3, None], P[..., :3, 3], about[..., _ROWS, _COLUMNS]], axis=-1)


def is_physical(phi: Array) -> bool:
    """Whether the pseudo-inertia is positive definite, seen at the body's own size."""
    m, P = phi[0], pseudo_inertia(phi)
    if not np.isfinite(phi).all() or m <= 0:
        return False
    about_com = P[:3, :3] - np.outer(phi[1:4], phi[1:4]) / m
    size = np.trace(P[:3, :3])
    return bool(np.linalg.eigvalsh(about_com)[0] > -1e-12 * max(float(size), 1e-300))


def nearest_physical(phi: Array, radius: float = 0.01) -> Array:
    """A physical phi with the same mass and centre and clipped second moments.

    Args:
        phi: (10,) with a positive mass.
        radius: m, smallest spread of the mass that is left along each axis.
    """
    P = pseudo_inertia(phi)
    h, m = P[:3, 3], max(float(P[3, 3]), 1e-6)
    values, axes = np.linalg.eigh(P[:3, :3] - np.outer(h, h) / m)
    P[:3, :3] = (axes * np.maximum(values, m * radius**2)) @ axes.T + np.outer(h, h) / m
    P[3, 3] = m
    return np.asarray(phi_of_pseudo(P))


def log_cholesky(phi: Array) -> Array:
    """eta (10,) of a physical phi (10,).

    Raises:
        InputError: phi is not physical.
    """
    P = pseudo_inertia(phi)
    # The upper root of P is the lower root of P with both axes reversed, reversed again.
    try:
        U = np.linalg.cholesky(P[::-1, ::-1])[::-1, ::-1]
    except np.linalg.LinAlgError:
        raise InputError(
            f"no body has the inertial parameters {np.array2string(phi, precision=4)}: their "
            "pseudo-inertia is not positive definite."
        ) from None
    scale = U[3, 3]
    d, s = np.log(np.diag(U)[:3] / scale), U / scale
    return np.array([np.log(scale), *d, s[0, 1], s[1, 2], s[0, 2], *s[:3, 3]])


@kernel
def phi_of_log_cholesky(eta: Array) -> tuple[Array, Array]:
    """phi (10,) of eta (10,), and its derivative (10, 10): row i is d phi_i / d eta."""
    scale = np.exp(eta[0])
    U = np.zeros((4, 4))
    for k in range(3):
        U[k, k] = scale * np.exp(eta[1 + k])
        U[k, 3] = scale * eta[7 + k]
    U[0, 1], U[1, 2], U[0, 2], U[3, 3] = scale * eta[4], scale * eta[5], scale * eta[6], scale
    P = U @ U.T
    phi, J = np.empty(10), np.empty((10, 10))
    _phi_of(P, phi)
    for e in range(10):
        dU = np.zeros((4, 4))
        if e == 0:
            dU[:] = U
        elif e < 4:
            dU[e - 1, e - 1] = U[e - 1, e - 1]
        elif e < 7:
            dU[0 if e != 5 else 1, 1 if e == 4 else 2] = scale
        else:
            dU[e - 7, 3] = scale
        half = dU @ U.T
        _phi_of(half + half.T, J[:, e])
    return phi, J


@kernel
def _phi_of(P: Array, phi: Array) -> None:
    """`phi_of_pseudo` of one matrix."""
    phi[0], phi[1], phi[2], phi[3] = P[3, 3], P[0, 3], P[1, 3], P[2, 3]
    phi[4], phi[6], phi[9] = P[1, 1] + P[2, 2], P[0, 0] + P[2, 2], P[0, 0] + P[1, 1]
    phi[5], phi[7], phi[8] = -P[0, 1], -P[0, 2], -P[1, 2]
