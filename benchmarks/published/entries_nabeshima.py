"""What is stored of the studies of Nabeshima and Kuniyoshi, and what the page tells of them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from published.entry import RARE, SHARES, Entry, Told

PICTURE = "a picture"
"""Where the paper draws and gives no number."""
READINGS = {
    "SSD 0.0003, speed 0.5": "SSD 0.0003, x0.5", "SSD 0.001, speed 0.5": "SSD 0.001, x0.5",
    "SSD 0.001, speed 0.25": "SSD 0.001, x0.25", "SSD 0.1, speed 0.125": "SSD 0.1, x0.125",
    "SSD 0.1, speed 0.5": "SSD 0.1, x0.5",
}  # fmt: skip
WHO = {"faithful": "published", "better": "ours"}
CASES = {
    "faithful": "published", "better": "ours",
    "faithful_outside": "published, outside", "better_outside": "ours, outside",
}  # fmt: skip
"""Of the wrist's studies: offset removed and slow, as the paper presumes, or not."""


def nabeshima() -> Iterable[Entry]:
    """One entry a study."""
    yield from (_figure3(), _figure4(), _figure5(), _hand_eye(), _corners(), _find_body())
    yield from (_figure8(), _figure9(), _rendered(), _figure10(), _figure11(), _touch(), _payload())
    yield _life()


def _entry(
    figure: str, small: Mapping[str, Any], full: Mapping[str, Any], told: Mapping[str, Told],
    keys: Iterable[str] = (), least: Mapping[str, float] | None = None, copies: int = 5,
) -> Entry:  # fmt: skip
    """Held to what it tells, and to `keys`; ends of distributions are told but not held."""
    return Entry(
        "nabeshima", figure, small, full, copies=copies, keys=(*told, *keys), leave=RARE,
        least=SHARES | dict(least or {}), told=told,
    )  # fmt: skip


def _figure3() -> Entry:
    told = {
        f"333.{key}": Told(f"{key} of what is found 333 ms after the onset, confirmed", PICTURE)
        for key in ("precision", "recall")
    }
    return _entry("figure3", {"runs": 1}, {"runs": 20}, told)


def _figure4() -> Entry:
    told = {
        key: Told(f"{words} after one motion, confirmed", PICTURE)
        for key, words in (
            ("precision", "precision"), ("recall", "recall"),
            ("joint_right_share", "share of cells whose joint is right"),
        )
    }  # fmt: skip
    return _entry("figure4", {"runs": 1}, {"runs": 20}, told)


def _figure5() -> Entry:
    says = {"faithful": "any motion", "faithful_share": "a third of the motions", "better": "ours"}
    told = {
        f"{name}.{key}": Told(f"15 motions, confirmed, {words}: {key}", PICTURE)
        for name, words in says.items()
        for key in ("precision", "recall")
    }
    return _entry("figure5", {"runs": 1, "motions": 3}, {"runs": 2}, told, copies=3)


def _hand_eye() -> Entry:
    says = {
        "faithful": "published, 30 s", "faithful_at_stop": "published, where it stops",
        "better": "ours, 30 s", "certificate": "ours, where it is certified",
    }  # fmt: skip
    told = {
        f"{name}.{key}.median": Told(f"{words}: {what}, median")
        for name, words in says.items()
        for key, what in (
            ("rotation_deg", "camera's turn, deg"), ("camera_mm", "camera, mm"),
            ("tip_mm", "tip, mm"),
        )
    }  # fmt: skip
    told |= {
        "faithful_at_stop.seconds.median": Told("published: stops after, s", "32"),
        "certificate.seconds_median": Told("ours: certified after, s"),
    }
    return _entry("hand-eye", {"runs": 3}, {}, told, ("nees", "certificate.*share"))


def _corners() -> Entry:
    told = {
        "rotation_deg.median": Told("camera turned wrong, deg"),
        "camera_mm.median": Told("camera misplaced, mm"),
        "on_hand_share.median": Told("share of the corners on the hand"),
        "within_bounds": Told("films in which both errors are within their bounds, of 2"),
    }
    small = {"runs": 1, "waggle": 2.0, "seconds": 3.0}
    least = {"*deg*": 0.5, "*_mm*": 20.0}
    return _entry("corners", small, {"runs": 2}, told, least=least, copies=3)


def _find_body() -> Entry:
    says = {
        "faithful": "any, confirmed", "faithful_share": "a third, confirmed",
        "faithful_outside": "any", "faithful_outside_share": "a third",
        "better_confirmed": "ours, confirmed", "better": "ours",
    }  # fmt: skip
    told = {
        f"{name}.always.{k}.{key}": Told(f"{k} motions, {words}: {key}", PICTURE)
        for k in (1, 5, 15)
        for name, words in says.items()
        for key in ("precision", "recall")
    }
    told["delay_error_ms.median"] = Told("delay of the camera learned within, ms")
    return _entry(
        "find-body", {"runs": 1, "motions": 3}, {"runs": 7}, told,
        least={"*recall": 0.5, "*precision": 0.3, "delay*": 5.0},
    )  # fmt: skip


def _course(name: str, who: str, words: str) -> dict[str, Told]:
    """The five events of figures 8 and 9 in a reading."""
    at = f"readings.{name}.{who}"
    return {
        f"{at}.first_known_s.median": Told(f"{words}: known after, s", "59, 27 of them to find it"),
        f"{at}.detected": Told(f"{words}: share of changes noticed", "2 of 2"),
        f"{at}.known_again_s.tool.median": Told(f"{words}: rod known again, s", "26"),
        f"{at}.known_again_s.camera.median": Told(f"{words}: head known again, s", "10"),
    }


def _figure8() -> Entry:
    own = next(iter(READINGS))
    told = {
        key: one
        for who, words in WHO.items()
        for key, one in _course(own, who, f"{words}, {READINGS[own]}").items()
    }
    return _entry("figure8", {"runs": 2}, {"runs": 12}, told, least={"*_s.*": 10.0})


def _figure9() -> Entry:
    told = {}
    for name, reading in READINGS.items():
        for who, words in WHO.items():
            told |= _course(name, who, f"{reading}, {words}")
            at, says = f"readings.{name}.{who}", f"{reading}, {words}: false alarms"
            told[f"{at}.spurious_a_run"] = Told(f"{says} in 130 s", "0")
            told[f"{at}.false_alarms_per_hour"] = Told(f"{says} an hour of watching", "0")
    least = {"*_s.*": 10.0, "*spurious*": 2.0, "*better.false_alarms_per_hour": 60.0}
    return _entry("figure9", {"runs": 2}, {"runs": 12}, told, least=least)


def _rendered() -> Entry:
    says = {"faithful": "SSD 0.0003", "faithful_printed": "SSD 0.1", "better": "ours"}
    told = {
        f"{who}.{key}": Told(f"{words}: {what}", paper)
        for who, words in says.items()
        for key, what, paper in (
            ("first_known_s.median", "known after, s", "59, 27 of them to find it"),
            ("detected", "share of changes noticed", "2 of 2"),
            ("spurious_a_run", "false alarms in 130 s", "0"),
        )
    }
    told["seen_share"] = Told("share of the corners that both pictures show")
    least = {"*known*": 10.0, "*detected": 1.0, "*spurious*": 4.0, "seen_share": 0.5}
    small = {"runs": 1, "seconds": 15.0}
    return _entry("rendered", small, {"runs": 2}, told, ("on_rod_share",), least, copies=3)


def _figure10() -> Entry:
    told = {}
    for case, words in CASES.items():
        told[f"{case}.satisfied_s"] = Told(f"{words}: is sure after, s", "6.6")
        for key, what in (("mass_pct", "mass off, %"), ("com_mm", "centre off, mm")):
            told |= {
                f"{case}.at.{second}.{key}": Told(f"{words}: {what}, after {second} s")
                for second in ("2", "6.6")
            }
    least = {"*mass_pct": 0.2, "*com_mm": 0.3}
    return _entry("figure10", {"runs": 2}, {}, told, least=least)


def _figure11() -> Entry:
    told = {
        f"{case}.{key}": Told(f"{words}: {what}", paper)
        for case, words in CASES.items()
        for key, what, paper in (
            ("begins_s", "touching begins by itself after, s", "6.6"),
            ("off_table_mm.median", "places off the table, mm, median", "up to 100"),
        )
    }
    return _entry("figure11", {"runs": 1}, {}, told, ("*.noticed",))


def _touch() -> Entry:
    says = {
        "faithful.{}.{}.readings.one": "published, one reading",
        "faithful.{}.{}.readings.mean": "published, mean of the touch",
        "better.{}.{}": "ours",
        "faithful_outside.{}.{}.readings.one": "published outside, one reading",
        "better_outside.{}.{}": "ours outside",
    }
    told = {
        f"{where.format(thing, force)}.{key}": Told(f"{thing}, {force} N, {words}: mm, {what}")
        for thing in ("box", "rod")
        for force in ("0.5", "1", "2", "5")
        for where, words in says.items()
        for key, what in (("median_mm", "median"), ("p95_mm", "95 %"))
    }
    keys = ("better*.unnoticed", "better*.false_per_hour")
    return _entry(
        "touch", {"runs": 4, "hours": 0.02}, {"runs": 60, "hours": 0.02}, told, keys,
        least={"*median_mm": 0.3},
    )  # fmt: skip


def _payload() -> Entry:
    told = {}
    for speed in ("0.15", "0.5", "1"):
        for reading in ("printed", "weighted", "least squares", "at rest"):
            name = f"faithful.speeds.{speed}.readings.{reading}.seconds_to_1pct_1mm.median"
            told[name] = Told(f"x{speed}, {reading}: s to 1 % and 1 mm")
        for case, words in (("better", "ours"), ("better_outside", "ours, outside")):
            name = f"{case}.speeds.{speed}.seconds_to_1pct_1mm.median"
            told[name] = Told(f"x{speed}, {words}: s to 1 % and 1 mm")
    for case, words in CASES.items():
        told[f"{case}.mass_pct"] = Told(f"{words}, after 40 s: mass off, %")
        told[f"{case}.com_mm"] = Told(f"{words}, after 40 s: centre off, mm")
    keys = ("better*coverage", "better*physical_share", "*.reached")
    least = {"*coverage*": 0.6, "*_pct": 0.02, "*com_mm": 0.02, "*seconds*": 1.0}
    return _entry("payload", {"runs": 2}, {}, told, keys, least)


def _life() -> Entry:
    told = {
        "certified_s.median": Told("hand and eye certified after, s, median", "59"),
        "certified_s.p90": Told("the same, 90 %"),
        "certificates": Told("certificates"),
        "false_certificates": Told("certificates that were not true"),
        "false_alarms_per_hour": Told("false alarms an hour", "0"),
        "rotation_deg": Told("camera turned wrong while it is known, deg, median"),
        "camera_mm": Told("camera misplaced while it is known, mm, median"),
        "inside_bound": Told("share of the time within the stated 99 % bound"),
        **{
            f"changes.{kind}.{key}": Told(f"{words}: {what}", said)
            for kind, words, again in (
                ("slip", "tool slips", "26"), ("head", "head turns", "10"),
                ("swap", "tool is swapped", ""),
            )
            for key, what, said in (
                ("noticed", "share noticed", ""), ("blamed", "share blamed rightly", ""),
                ("noticed_s.median", "noticed after, s", "1" if again else ""),
                ("certified_again_s.median", "known again after, s", again),
            )
        },
    }  # fmt: skip
    small, full = {"runs": 1, "seconds": 40.0}, {"runs": 8, "seconds": 100.0}
    return _entry("life", small, full, told, copies=4)
