"""What am I holding? An arm waves things about and feels their weight at its wrist.

    python examples/10_what_am_i_holding.py

The sensor has noise, an offset, and sits a degree off its mount; the motion is known from encoders
alone. Nobody says when something is grasped or let go.
"""

from __future__ import annotations

import numpy as np

from bodyschema import Inertia, LoadLearner, Monitor, WrenchStream
from bodyschema.simulation.loads import Held, draw_motion, draw_sensor, joined, record, wire_box

rng = np.random.default_rng(0)
box = wire_box()
hand = Inertia(0.45, np.array([0.0, 0.01, 0.05]), np.diag([6e-4, 6e-4, 4e-4]))
held = [Held(0.0, hand), Held(12.0, joined(hand, box)), Held(24.0, hand)]
motion = draw_motion(rng, 36.0, speed=0.5, rate=100.0)
samples = record(motion, held, draw_sensor(rng, np.radians(1)), rng)
print(f"hand {hand.mass:.3f} kg; box {box.mass:.3f} kg, grasped at 12 s, let go at 24 s")

stream, monitor = WrenchStream(), Monitor(LoadLearner())
buffer, state = stream.start(), monitor.start()
known = []
for i in range(len(samples)):
    buffer, mean = stream.step(buffer, samples.take(slice(i, i + 1)))
    if mean is None:
        continue
    state, info = monitor.step(state, (mean,))
    if info.event == "alarm":
        print(f"{samples.time[i]:6.2f} s  something changed")
    elif info.event:
        load = state.belief.load
        known.append(load)
        print(f"{samples.time[i]:6.2f} s  {info.change or info.event}: now {load.mass:.3f} kg")

# The difference of two loads in one frame is what was grasped.
thing = Inertia.from_phi(known[1].phi - known[0].phi)
print(f"grasped: {thing.mass:.3f} kg")
print(f"  its centre of mass: {np.round(1e3 * thing.com, 1)} mm, truth {1e3 * box.com}")

bounds = monitor.learner.certificate(state.belief).bounds
print(f"the hand's mass is known to {1e3 * bounds['mass']:.2f} g,", end=" ")
print(f"its centre to {1e3 * bounds['centre of mass']:.2f} mm (99 %)")
