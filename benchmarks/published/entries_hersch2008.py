"""What is stored of the studies of Hersch, Sauser and Billard (2008)."""

from __future__ import annotations

from collections.abc import Iterable

from published.entry import Entry, Told

JOINTS = (1, 3, 5, 7)
REACHES = ("180.0", "135.0", "90.0", "45.0", "22.5")
SKINS = {"0.03": "3 cm", "0.1": "10 cm", "0.2": "20 cm"}
LIMBS = {"last_limb": "last limb adapts", "whole_arm": "whole arm adapts"}
CHANGES = (
    "tool dropped", "tip moved 10 cm", "tip moved 5 cm", "upper arm moved 10 cm",
    "camera moved 10 cm",
)  # fmt: skip


def hersch2008() -> Iterable[Entry]:
    """One entry a study."""
    paper = "hersch2008"
    yield Entry(
        paper, "figure3", {"runs": 200}, keys=("joints.*",),
        # One run of a long tail moves mean and maximum as far as it likes.
        leave=("*samples_max", "*samples_mean"),
        least={"joints.*.not_converged": 3.0},
        told={
            f"joints.{n}.{key}": Told(f"{n} joints: {words}", said)
            for n in JOINTS
            for key, words, said in (
                ("not_converged", "not converged, of 10,000", "0" if n == 1 else "< 100"),
                ("samples_mean", "samples, mean", ""),
                ("samples_median", "samples, median", ""),
                ("samples_p95", "samples, 95 %", ""),
            )
        },
    )  # fmt: skip
    yield Entry(
        paper, "figure4", {"runs": 5}, {"runs": 60}, copies=8,
        keys=("not_converged", "samples_median"), least={"not_converged": 2.0},
        told={
            "not_converged": Told("not within 1 deg after 4000 samples, of 60"),
            "samples_median": Told("samples until all axes stay within 1 deg, median", "a picture"),
        },
    )  # fmt: skip
    yield Entry(
        paper, "figure7", {"runs": 4}, copies=6, keys=("skins.*",),
        least={"*.nothing": 2.0, "*.rough": 2.0, "*.pairs": 2.0},
        told={
            f"skins.{skin}.{key}": Told(f"skin of {size}: {words}", "nothing")
            for skin, size in SKINS.items()
            for key, words in (
                ("pairs", "pairs of arms that touch"), ("nothing", "learned from nothing"),
                ("rough", "learned from a rough body"),
            )
        },
    )  # fmt: skip
    yield Entry(
        paper, "theorem1", {"runs": 50}, keys=("widest_deg", "ranges.*"),
        least={"*.fixed_*": 0.06},
        told={
            "widest_deg": Told("widest range with one minimum, v varied, deg", "not varied"),
            **{
                f"ranges.{reach}.{key}": Told(f"+-{float(reach):g} deg: {words}", "0")
                for reach in REACHES
                for key, words in (
                    ("fixed_false_minimum", "share of problems with a false minimum"),
                    ("fixed_starts_caught", "share of starts caught"),
                )
            },
        },
    )  # fmt: skip
    yield Entry(
        paper, "figure10", {"runs": 4}, {"runs": 50}, copies=5,
        leave=("*samples_max", "*samples_p95", "*condition"),
        least={"*failed": 2.0, "*samples_median": 1.0},
        told={
            f"{case}{key}": Told(f"{seen}: {words}", said)
            for case, seen in (("", "hands and feet"), ("alternating.", "and joints in turn"))
            for key, words, said in (
                ("failed", "failed, of each case", "converges" if not case else "faster"),
                ("samples_median", "postures, median", ""),
                ("samples_p95", "postures, 95 %", ""),
                ("samples_max", "postures, most", ""),
                ("identifiable", "parameters that can be told, of 135", "" if not case else "all"),
            )
        },
    )  # fmt: skip
    yield Entry(
        paper, "figure11", {"runs": 1}, {"runs": 20}, copies=5,
        keys=("*.identifiable", "*.parameters", "*.failed", "*.prediction", "*.centres_mean"),
        least={"*.failed": 1.0, "*.prediction": 1e-5, "*.shortest.centres_mean": 1e-3},
        told={
            f"{case}.{key}": Told(f"{seen}: {words}", said)
            for case, seen in (("ends", "hands and feet"), ("alternating", "and joints in turn"))
            for key, words, said in (
                ("learned.prediction", "error of what it expects, m", "0, when converged"),
                ("learned.centres_mean", "joints' centres off as learned, m",
                 "differ" if case == "ends" else "no ambiguity"),
                ("shortest.centres_mean", "the same with shortest links, m", ""),
            )
        },
    )  # fmt: skip
    steps = {"last_limb": "2000", "whole_arm": "1000"}
    yield Entry(
        paper, "figure13", {"runs": 1}, {"runs": 6}, copies=4, keys=("learners.*", "changes.*"),
        # Quantiles of one robot that rarely cross, and the tails, are of no use.
        leave=("*.p95", "learners.*.steps.*", "*.paper_*", "learners.*.tip_mm.1",
               "changes.*.samples_to_decide.*", "changes.*.steps.1cm.*", "changes.*.steps.2cm.*"),
        least={"*.false_alarms_before": 1.0, "*.right_part": 1.0, "*.samples_to_notice.*": 4.0,
               "*.steps.5cm.*": 6.0},
        told={
            **{
                f"learners.{learner}_{limb}.{key}": Told(
                    f"{words}, {says}: {what}",
                    steps[limb] if learner == "online_gradient" and "5cm" in key else "",
                )
                for limb, says in LIMBS.items()
                for learner, words in (("online_gradient", "gradient"), ("smoother", "smoother"))
                for key, what in (
                    ("steps.5cm.median", "samples to 5 cm"), ("tip_mm.3000", "tip at 3000, mm"),
                    ("elbow_mm", "elbow at 3000, mm"),
                )
            },
            **{
                f"changes.{name}.{key}": Told(f"{name}: {words}", "not tried")
                for name in CHANGES
                for key, words in (
                    ("samples_to_notice.median", "noticed after, samples"),
                    ("right_part", "share blamed rightly"),
                    ("steps.5cm.median", "back under 5 cm after, samples"),
                )
            },
        },
    )  # fmt: skip
