"""Full-size results of the studies, and a gate: a small run of each must fall inside their spread.

check.py     the command: run small ones and compare, or store a full-size one
entry.py     what is run, full and small, and which numbers count
entries.py   one entry a study; those of a paper in entries_PAPER.py
store.py     a full run and its small copies -> PAPER_FIGURE.json
spread.py    the rule for what is inside
"""
