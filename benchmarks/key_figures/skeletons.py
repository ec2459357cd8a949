"""Bodies that are learned from nothing."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from bodyschema.studies.pool_chains import PoolProtocol, noisy_pool_run, pool_run
from bodyschema.studies.registry import study_class
from bodyschema.studies.runner import run_study
from key_figures.figure import Values

CHAINS = {3: 40, 7: 20}
"""Joints -> random chains."""

NOISY = PoolProtocol(noise=0.01, outliers=0.05)


def pool(data: Path) -> Values:
    """Samples until all predictions hold to 0.1 % of the chain; noisy chains over their bound."""
    runs = {n: [pool_run(PoolProtocol(), n, 0, run)[1] for run in range(k)]
            for n, k in CHAINS.items()}  # fmt: skip
    noisy = [noisy_pool_run(NOISY, 3, 0, run)[-1, 0] for run in range(20)]
    return {
        **{f"samples_{n}": float(np.median(counts)) for n, counts in runs.items()},
        "failed": sum(count < 0 for counts in runs.values() for count in counts),
        "noisy_over_bound": float(np.median(noisy)),
    }


def humanoid(data: Path) -> Values:
    """24 joints by looking at hands and feet: postures until it expects them within 1 %."""
    samples = study_class("hersch2008", "figure10")(runs=10)
    shape = study_class("hersch2008", "figure11")(runs=2)
    counted = samples.summary(run_study(samples, 1))
    drawn = shape.summary(run_study(shape, 1))["ends"]
    return {
        "samples": counted["samples_median"],
        "failed": drawn["failed"],
        "determined": drawn["identifiable"],
        "centres": 1e3 * drawn["shortest"]["centres_mean"],
    }
