"""How long tests wait for a process or a thread: a bound on hanging, not on speed."""

PATIENCE = 300.0
"""[s]"""
