"""The picture of profiles that wear. Apart from `follow`, so that processes that only solve load no matplotlib."""

from __future__ import annotations

from typing import Any

from thermoroll_cli.plots.profile_figures import wear_figure
from thermoroll_cli.plots.service_figure import service_figure
from thermoroll_cli.problem.problem import BODIES
from thermoroll_cli.studies.worn.follow import Evolution


def evolution_figure(done: Evolution) -> Any:
    """A figure: profiles and loads of one contact over the distance, or outlines of a wheelset and what changes with them."""
    if done.outlines:
        return service_figure(done.case.settings.title, done.rows, done.outlines, converged=done.converged)
    kept, asked = done.snapshots, done.case.problem.wear
    assert asked is not None
    regimes = {body: getattr(asked, body).regimes for body in BODIES}
    return wear_figure(done.case.settings.title, kept.y, kept.profiles, kept.loads, kept.distances, work=kept.work,
                       regimes=regimes, converged=done.converged)
