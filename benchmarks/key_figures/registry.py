"""All key figures: unit, which way is better, tolerance and why. A new one joins by a line here.

Tolerances are for another way to the same answer: another order of sums, another solver, a start
elsewhere. Seeds are fixed, so that a change beyond them is a change of the product.
"""

from __future__ import annotations

from key_figures.figure import Figure, Part

SETTLED = "another solver settles a hundredth of a millimetre away"
GATED = "one row more or less behind the gate of outliers"
FOLDS = "what is held out is one pass over few rows: the way matters"
COUNT = "every one counts"
DATA = "the robot and the recording as they come, nothing is fitted to chance"
SEEDS = "less than other seeds move it by"
WAYS = "the spread between movements over the root of their number"
FEW = "few sequences a track"
FEW_MISSES = "one miss more is chance"
SHARE = "few trials: one of them is about this much"
CHANCE = "a difference this small is lost in any use"
BUSY = "another machine, or a busy one"

PARTS: tuple[Part, ...] = (
    Part("calibrate_3000", "speed:calibrate_3000", (
        Figure("cpu", "s", "lower", 0.5, BUSY, relative=True),
    )),
    Part("calibrate_300", "speed:calibrate_300", (
        Figure("cpu", "s", "lower", 0.5, BUSY, relative=True),
    )),
    Part("calibrate_fr3", "speed:calibrate_fr3", (
        Figure("cpu", "s", "lower", 0.5, BUSY, relative=True),
    ), needs=("fr3_eyeinhand_kincal",)),
    Part("steps", "speed:steps", (
        Figure("filter", "us", "lower", 0.5, BUSY, relative=True),
        Figure("kinematics", "ms", "lower", 0.5, BUSY, relative=True),
        Figure("imagination", "ms", "lower", 0.5, BUSY, relative=True),
        Figure("payload", "us", "lower", 0.5, BUSY, relative=True),
    )),
    Part("fr3", "calibration:fr3", (
        Figure("nominal", "mm", "equal", 0.01, DATA),
        Figure("clean", "mm", "lower", 0.01, SETTLED),
        Figure("outliers_3cm", "mm", "lower", 0.02, GATED),
        Figure("outliers_20cm", "mm", "lower", 0.02, GATED),
        Figure("median", "mm", "lower", 0.05, "the median of 114 jumps from row to row"),
    ), needs=("fr3_eyeinhand_kincal",)),
    Part("fr3_peers", "calibration:fr3_peers", (
        Figure("clean", "mm", "lower", 0.01, SETTLED),
        Figure("outliers_3cm", "mm", "lower", 0.02, GATED),
        Figure("outliers_20cm", "mm", "lower", 0.02, GATED),
        Figure("with_field", "mm", "lower", 0.05, "the field's optimiser has several ends"),
        Figure("one_pass", "mm", "lower", 0.10, FOLDS),
    ), needs=("fr3_eyeinhand_kincal",)),
    Part("talos", "calibration:talos", (
        Figure("nominal", "mm", "equal", 0.05, SETTLED),
        Figure("offsets", "mm", "lower", 0.03, SETTLED),
        Figure("chosen", "mm", "lower", 0.03, SETTLED),
        Figure("from_nothing", "mm", "lower", 0.05, GATED),
    ), needs=("figaroh_talos_contact",)),
    Part("talos_one_pass", "calibration:talos_one_pass", (
        Figure("filter", "mm", "lower", 0.10, FOLDS),
        Figure("smoother", "mm", "lower", 0.05, FOLDS),
    ), needs=("figaroh_talos_contact",)),
    Part("tiago", "calibration:tiago", (
        Figure("chosen", "mm", "lower", 0.05, GATED),
        Figure("clock_fault_p", "1", "lower", 0.01, "still a fault at 1 %"),
        Figure("bad_rows", "rows", "equal", 2, "34 rows; some stand on the edge"),
    ), needs=("figaroh_tiago_mocap",)),
    Part("coverage", "calibration:coverage", (
        Figure("clean", "off 95 %", "lower", 0.02, SHARE),
        Figure("outliers", "off 95 %", "lower", 0.02, SHARE),
        Figure("fr3", "off 95 %", "lower", 0.03, "three of 114 rows"),
    ), needs=("fr3_eyeinhand_kincal",)),
    Part("check", "calibration:check", (
        Figure("detected", "share", "higher", 0.0, COUNT),
        Figure("blamed", "share", "higher", 0.1, SHARE),
        Figure("false_alarms", "share", "lower", 0.05, SHARE),
        Figure("null_named", "of 10", "higher", 0, COUNT),
        Figure("null_invented", "of 100", "lower", 0, COUNT),
    )),
    Part("hand_eye_points", "hand_eye:points", (
        Figure("camera", "mm", "lower", 0.05, SEEDS),
        Figure("turn", "deg", "lower", 0.003, SEEDS),
        Figure("tip", "mm", "lower", 0.01, SEEDS),
        Figure("certified", "s", "lower", 1.0, SEEDS),
        Figure("false", "share", "lower", 0.0, COUNT),
        Figure("nees", "1", "lower", 2.0, "nine degrees of freedom, six scenes"),
    )),
    Part("hand_eye_poses", "hand_eye:poses", (
        Figure("eye", "mm", "lower", 0.03, SEEDS),
        Figure("eye_worst", "mm", "lower", 0.05, SEEDS),
        Figure("coverage_off", "off 95 %", "lower", 0.04, SHARE),
        Figure("determined", "share", "higher", 0.04, SHARE),
        Figure("one_axis_flagged", "share", "higher", 0.0, COUNT),
    )),
    Part("hand_eye_recorded", "hand_eye:recorded", (
        Figure("ur5", "mm", "lower", 0.2, GATED),
        Figure("ur5_median", "mm", "lower", 0.1, GATED),
        Figure("eth", "mm", "lower", 0.1, GATED),
        Figure("eth_lag", "ms", "equal", 1.0, "two standard deviations of the lag"),
        Figure("eth_apart", "mm", "lower", 0.5, GATED),
    ), needs=("ur5_artag_handeye", "eth_handeye")),
    Part("kinhec", "hand_eye:kinhec", (
        Figure("motion", "mm", "lower", 0.3, FEW),
        Figure("motion_unflagged", "mm", "lower", 2.0, "the worst of few"),
        Figure("outliers", "mm", "lower", 0.1, FEW),
        Figure("outliers_mean", "mm", "lower", 0.3, FEW),
        Figure("temporal", "mm", "lower", 0.1, FEW),
        Figure("false_flags", "share", "lower", 0.0, COUNT),
    )),
    Part("pool", "skeletons:pool", (
        Figure("samples_3", "samples", "lower", 1, SEEDS),
        Figure("samples_7", "samples", "lower", 2, SEEDS),
        Figure("failed", "of 60", "lower", 0, COUNT),
        Figure("noisy_over_bound", "1", "lower", 0.05, SEEDS),
    )),
    Part("humanoid", "skeletons:humanoid", (
        Figure("samples", "postures", "lower", 1, SEEDS),
        Figure("failed", "of 2", "lower", 0, COUNT),
        Figure("determined", "of 135", "equal", 0, "a property of body and sight"),
        Figure("centres", "mm", "lower", 0.1, "the shortest links are one body"),
    )),
    Part("payload", "wrist:held", (
        Figure("known_s", "s", "lower", 0.25, SEEDS),
        Figure("certified_s", "s", "lower", 0.25, SEEDS),
        Figure("mass", "%", "lower", 0.002, SEEDS),
        Figure("centre", "mm", "lower", 0.002, SEEDS),
        Figure("coverage_off", "off 95 %", "lower", 0.05, SHARE),
        Figure("physical", "share", "higher", 0.0, COUNT),
    )),
    Part("payload_changes", "wrist:changes", (
        Figure("delay", "s", "lower", 0.1, SEEDS),
        Figure("missed", "of 24", "lower", 0, COUNT),
        Figure("named", "share", "higher", 0.05, FEW_MISSES),
        Figure("again", "s", "lower", 0.5, SEEDS),
        Figure("false_alarms", "in 0.5 h", "lower", 0, COUNT),
    )),
    Part("touch", "wrist:touched", (
        Figure("place", "mm", "lower", 0.03, SEEDS),
        Figure("place_p95", "mm", "lower", 0.1, SEEDS),
        Figure("unnoticed", "of 60", "lower", 0, COUNT),
        Figure("held_off", "off 95 %", "lower", 0.05, SHARE),
        Figure("refused", "share", "higher", 0.05, SHARE),
        Figure("false", "in 0.3 h", "lower", 0, COUNT),
    )),
    Part("find_body", "pictures:found_body", (
        Figure("precision", "share", "higher", 0.01, SHARE),
        Figure("recall", "share", "higher", 0.02, SHARE),
        Figure("joint", "share", "higher", 0.05, SHARE),
        Figure("delay", "ms", "lower", 1.0, SEEDS),
    )),
    Part("tracker", "pictures:tracker", (
        Figure("own", "mm", "lower", 0.01, WAYS),
        Figure("own_turn", "deg", "lower", 0.01, WAYS),
        Figure("wrong", "mm", "lower", 0.05, WAYS),
        Figure("wrong_turn", "deg", "lower", 0.03, WAYS),
        Figure("reaching", "mm", "lower", 0.13, WAYS),
        Figure("wrong_nees", "1", "lower", 3.0, "six degrees of freedom, three movements"),
    )),
    Part("vislab", "pictures:vislab_icub", (
        Figure("converged", "of 4", "higher", 0, COUNT),
        Figure("repeatability", "mm", "lower", 0.05, SEEDS),
        Figure("to_published", "mm", "lower", 0.1, SEEDS),
        Figure("iou", "1", "higher", 0.003, CHANCE),
    ), needs=("vislab_icub_sim",)),
    Part("med7", "pictures:med7", (
        Figure("offsets", "deg", "lower", 0.03, "a fifth of the least stated deviation"),
        Figure("repeat", "deg", "lower", 0.03, "a fifth of the least stated deviation"),
        Figure("iou", "1", "higher", 0.003, CHANCE),
        Figure("residual", "px", "lower", 0.02, CHANCE),
    ), needs=("roboreg_med7_zed2i",)),
    Part("joint_jump", "monitors:joints", (
        Figure("certified", "s", "lower", 2.0, SEEDS),
        Figure("detected", "share", "higher", 0.0, COUNT),
        Figure("delay", "s", "lower", 0.1, "three samples"),
        Figure("again", "s", "lower", 0.5, SEEDS),
        Figure("blamed", "share", "higher", 0.0, COUNT),
        Figure("false_alarms", "alarms", "lower", 0, COUNT),
    )),
    Part("image_jump", "monitors:images", (
        Figure("certified", "s", "lower", 1.0, SEEDS),
        Figure("detected", "share", "higher", 0.0, COUNT),
        Figure("delay", "s", "lower", 0.2, "two pictures"),
        Figure("again", "s", "lower", 0.5, SEEDS),
        Figure("blamed", "share", "higher", 0.0, COUNT),
        Figure("false_alarms", "alarms", "lower", 0, COUNT),
    )),
    Part("calm", "monitors:calm", (
        Figure("hours", "h", "higher", 0.02, "a later certificate is a shorter watch"),
        Figure("alarms", "alarms", "lower", 1, "one alarm a day is what was asked for"),
        Figure("confirmed", "alarms", "lower", 0, COUNT),
        Figure("wrong", "certificates", "lower", 0, COUNT),
    )),
    Part("hard_streams", "monitors:hard", (
        Figure("noticed", "of 10", "higher", 0, COUNT),
        Figure("blamed", "of 10", "higher", 1, FEW_MISSES),
        Figure("false_changes", "changes", "lower", 0, COUNT),
        Figure("wrong", "certificates", "lower", 0, COUNT),
    )),
)  # fmt: skip
