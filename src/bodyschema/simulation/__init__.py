"""The 'real robot' of demos, tests and studies: MuJoCo moves it, pinhole cameras look at it.

Nothing that learns imports this folder.
"""
