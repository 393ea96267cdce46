"""The figures of one folding, from its travel."""

from __future__ import annotations

from hcsearch.designs.records import FlightNumbers
from hcsearch.springs.dynamics.panels import panel_bodies
from hcsearch.springs.flight.travel import Travel


def figures_of(travel: Travel) -> FlightNumbers:
    """Return the figures of a folding in a scene."""
    bodies = panel_bodies(travel.linkage, travel.setup.density)
    return FlightNumbers(mass=sum(body.mass for body in bodies))
