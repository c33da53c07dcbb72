"""The ROS 2 package: entry points of the Python package firstlap, launch files and configuration."""

from pathlib import Path

from setuptools import setup

NAME = "firstlap_ros"
FOLDERS = ("launch", "config", "rviz", "foxglove")

setup(
    name=NAME,
    version="0.1.0",
    packages=[NAME],
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["package.xml"]),
        *((f"share/{NAME}/{folder}", sorted(str(path) for path in Path(folder).iterdir())) for folder in FOLDERS),
    ],
    install_requires=["setuptools", "firstlap"],
    zip_safe=True,
    maintainer="firstlap",
    maintainer_email="firstlap@example.org",
    description="Race unknown tracks with a 2D LiDAR: a driving node for F1TENTH cars, and a simulator node",
    license="Apache-2.0",
    entry_points={
        "console_scripts": [
            f"drive = {NAME}.commands:drive",
            f"sim = {NAME}.commands:sim",
            f"preflight = {NAME}.commands:preflight",
        ]
    },
)
