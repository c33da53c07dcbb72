"""The numbers that the paper prints; those of its first and its last setting are in `FIRST` and `LAST`.

M. Fazekas, Z. Demeter, J. Tóth, Á. Bogár-Németh, G. Bári, "Evaluation of Local Planner-Based Stanley Control in
Autonomous RC Car Racing Series", IEEE IV 2024, arXiv 2408.15152.
"""

from __future__ import annotations

from collections.abc import Mapping

FIRST, LAST = "base", "race"
"""Our setups with the gains and speeds of settings 0 and 5."""
PUBLISHED = ("k_ang", "k_dist", "k_soft", "k_damp", "k_rate", "l_max", "v_min", "v_max")
"""Names of the parameters whose values the paper prints; all others are ours."""
CHANGES: Mapping[int, Mapping[str, float]] = {
    2: {"k_ang": 0.3, "l_max": 0.6, "v_min": 2.3, "v_max": 6.5},
    4: {"k_soft": 10.0, "k_damp": 10.0},
}
"""What the paper changes up to a setting; settings 1 and 3 are not printed."""
SETTING_LAPS: Mapping[int, float] = {0: 17.5, 2: 15.6, 4: 14.3, 5: 12.8, 6: 12.4}
"""Laps [s] of Figure 10; 6: 12.4 s, which the text calls not robust."""
NOT_ROBUST = 6
REACTIVE_LAP = 16.0
"""Lap [s] of the reactive drivers of the paper's race (Section V-B)."""
WINNER_LAP = 11.82
"""Lap [s] of the winner of that race, which had a map and a global line (Section V-B)."""
LAPS_BY_GROUP: Mapping[str, float] = {"reactive": REACTIVE_LAP, "local": SETTING_LAPS[5], "global": WINNER_LAP}
"""Laps [s] of Section V-B: reactive, local planning with Stanley control, map and global line."""
