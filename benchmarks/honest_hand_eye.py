"""Hand-eye alone, of `honesty.py`: how often a wrong place of the eye is given a green light.

    python benchmarks/honest_hand_eye.py --runs N [--json]

All options of `honesty.py` hold, the kind is "hand-eye" (honest/hand_eyes.py).
"""

from __future__ import annotations

import sys

import honesty

if __name__ == "__main__":
    sys.exit(honesty.main(["--kinds", "hand-eye", *sys.argv[1:]]))
