"""The 'real robot' of demos, tests and studies: MuJoCo moves it, pinhole cameras look at it.

Nothing that learns imports this folder.
"""

import os
import sys

# Draw without a screen unless the user has chosen; heeded when mujoco is first imported.
if sys.platform == "linux":
    os.environ.setdefault("MUJOCO_GL", "egl")
