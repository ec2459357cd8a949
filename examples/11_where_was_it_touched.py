"""Something pokes the cup in the robot's hand: when, where, and was it a poke at all?

A simulated arm waves a cup for 20 s and learns its load and the errors of its own wrist sensor.
Then it goes on moving, and listens: eight times a second it averages the last quarter of a second
and asks what the load does not explain. Three touches follow: a poke, a twist by something soft,
and a finger that slides along the wall.

python examples/11_where_was_it_touched.py    needs the extra sim
"""

from __future__ import annotations

import numpy as np

from bodyschema import KnownLoad, LoadLearner, TouchSearch, WrenchStream
from bodyschema.learners.touch.unexplained import Unexplained
from bodyschema.senses.wrench_means import Averaging
from bodyschema.simulation.contacts import draw_contact
from bodyschema.studies.touch_runs import draw_wrist

rng = np.random.default_rng(11)
wrist = draw_wrist("mesh", "identified", speed=0.5, rng=rng)

learner, quiet = LoadLearner(), wrist.move(20.0, rng)
belief, _ = learner.step(learner.start(), (Averaging().means(quiet),))
print(f"a cup of {belief.load.mass:.4f} kg; truly {wrist.held.load.mass:.4f} kg")

search = TouchSearch.taught(quiet, KnownLoad.of(belief.solution), wrist.held.solid)
stream, finder = WrenchStream(search.averaging), search.finder

kinds = ("point", "soft", "moving")
contacts = [
    draw_contact(wrist.held.solid, 2.0, kind, begins, rng)
    for kind, begins in zip(kinds, (1.0, 3.5, 6.0), strict=True)
]
samples = wrist.move(8.0, rng, contacts)

buffer, state = stream.start(), None
for i in range(len(samples)):
    buffer, mean = stream.step(buffer, samples.take(slice(i, i + 1)))
    if mean is None:
        continue
    left = Unexplained.of(mean, search.load)
    state = state or finder.start(left.factor.shape[2])
    for moment in left.moments():
        state, (felt,) = finder.step(state, moment)
        time = moment[0].time[0]
        if felt.event == "begins":
            print(f"\n{time:5.2f} s  something touches the cup")
        if felt.event == "ends":
            touch = felt.touch
            contact = min(contacts, key=lambda c: abs(c.begins - touch.begins))
            off = 1e3 * np.linalg.norm(touch.point - contact.point)
            print(
                f"{time:5.2f} s  over: {np.linalg.norm(touch.force):.2f} N, taken for "
                f"'{touch.verdict}' (truly '{contact.kind}')"
            )
            if touch.verdict == "point":
                std = 1e3 * np.sqrt(np.linalg.eigvalsh(touch.covariance)[-1])
                x, y, z = 1e3 * touch.point
                print(
                    f"         at ({x:.1f}, {y:.1f}, {z:.1f}) mm ± {std:.1f}, truly {off:.1f} off"
                )
