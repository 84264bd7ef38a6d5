"""A ball bearing."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from thermoroll_cli.problem.kinds import Answer, At, Kind
from thermoroll_cli.problem.names import BALL_SCALARS, BEARING_SCALARS, TOGETHER


class BearingKind(Kind):
    name, words = "bearing", "a ball bearing"
    tables = ("bearing",)
    rolls = False
    refused = ("geometry", "track", "wheelset", "history", "surface", "creepage", "force", "wear", "load.normal_N",
               "load.normal_N_mm", "load.hertz_pressure_MPa", "load.approach_um", "load.vertical_N", "rolling.speed_m_s",
               "friction.over_angle", "friction.across", "friction.left", "friction.right", "thermal.lower",
               "thermal.upper")  # fmt: skip
    refusal = "[bearing]", "[bearing] without it"
    solver = At("many_contacts.bearing.bearing_result.BearingSolver")
    warnings = At("many_contacts.bearing.bearing_result.bearing_warnings")
    facts = At("many_contacts.bearing.bearing_result.facts_of")
    plan = At("many_contacts.bearing.bearing_result.plan_of")
    answer = Answer(
        contact_name="ball_{ball}_{ring}", contact_begins=("ball_",), scalars=BEARING_SCALARS | TOGETHER,
        of_contacts=BALL_SCALARS, sentence="A bearing", shown_by="ball", columns_title="Balls",
        columns=("ball", "ring", "normal_N", "contact_angle_deg", "spin_to_roll", "ball_pitch_deg", "pressure_max_MPa",
                 "temperature_rise_max_lower_K", "Q_F_W"),
        figures={"loads": "plots.bearing_figures.loads_figure", "axes": "plots.bearing_figures.axes_figure",
                 "patches": "plots.bearing_figures.patches_figure"})

    def task(self, settings: Any, contact: Any) -> Any:
        from thermoroll_cli.files.case_bearing import bearing_of

        return bearing_of(settings.bearing, contact)

    def geometry(self, settings: Any) -> Any:
        """A ball at the bottom of its inner groove stands for all contacts."""
        from thermoroll_cli.files.case_model import GeometryTable

        bearing, radius = settings.bearing, 0.5 * settings.bearing.ball_diameter_mm
        return GeometryTable(lower_radius_x_mm=max(0.5 * bearing.pitch_diameter_mm - radius, 1e-3 * radius),
                             lower_radius_y_mm=-bearing.conformity_inner * bearing.ball_diameter_mm,
                             upper_radius_x_mm=radius, upper_radius_y_mm=radius)

    def conflicts(self, sections: Mapping[str, Any]) -> Iterator[Any]:
        from thermoroll_cli.files.case_bearing import bearing_faults
        from thermoroll_cli.files.case_conflicts import Conflict, homogeneous

        table, why = sections.get("bearing"), "is not computed for bearings, which Hertz's contacts place"
        for path, message, allowed in () if table is None else (*bearing_faults(sections, table), *homogeneous(sections, why)):
            yield Conflict(path, message, allowed, at_key=path == ("bearing", "load"))


KINDS = (BearingKind(),)
