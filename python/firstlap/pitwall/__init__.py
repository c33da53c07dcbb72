"""The pit wall: a browser page that shows every scan and what the driver made of it, and turns its knobs.

A `Source` (a simulated race, a recording, a car over ROS 2) hands over its newest `Frame`; `Scene`, `Plots` and
`LapTable` draw it; `Panel` changes the source. Nothing here is ever waited for by what drives.
"""
