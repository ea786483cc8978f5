"""Builds the package with colcon."""

from setuptools import setup

NAME = "graphengine_ros"

setup(
    name=NAME,
    version="0.2.0",
    packages=[NAME],
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{NAME}"]),
        (f"share/{NAME}", ["package.xml"]),
        (f"share/{NAME}/launch", ["launch/sim.launch.py"]),
    ],
    install_requires=["setuptools"],
    zip_safe=True,
    maintainer="The graphengine developers",
    maintainer_email="graphengine@example.com",
    description="Launches simulations of graphengine, which is installed in a Python environment of its own.",
    license="Apache-2.0",
    entry_points={"console_scripts": [f"graphrun = {NAME}.graphrun:main"]},
)
