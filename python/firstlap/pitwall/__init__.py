"""The pit wall: a browser page that shows every scan and the driver's plan, and changes its parameters.

A `Source` (a simulated race, a recording, a car over ROS 2) provides its newest `Frame`; `Scene`, `Plots` and
`LapTable` draw it; `Panel` changes the source. The driving code never waits for anything here.
"""
