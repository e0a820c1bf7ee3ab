"""Pictures of results; the only user of matplotlib."""

from __future__ import annotations

from percuss.lazy import lazy_names

# matplotlib is slow to import: it loads with the first of these that is used.
_MODULES = {
    "Film": "animation",
    "Units": "style",
    "animate": "animation",
    "offscreen_figure": "style",
    "plot_basins": "basin_plot",
    "plot_branch": "branch_plot",
    "plot_chart": "chart_plot",
    "plot_coordinates": "structure_plot",
    "plot_confidence": "fit_plot",
    "plot_curves": "branch_plot",
    "plot_design": "design_plot",
    "plot_diagram": "diagram_plot",
    "plot_displacement": "motion_plot",
    "plot_enclosure": "enclosure_plot",
    "plot_fit": "fit_plot",
    "plot_fractions": "basin_plot",
    "plot_impact_velocities": "motion_plot",
    "plot_manifolds": "section_plot",
    "plot_mode_shapes": "structure_plot",
    "plot_motion": "motion_plot",
    "plot_multipliers": "orbit_plot",
    "plot_orbit": "orbit_plot",
    "plot_pareto": "design_plot",
    "plot_phase_portrait": "motion_plot",
    "plot_profiles": "fit_plot",
    "plot_response": "response_plot",
    "plot_singularity_set": "section_plot",
    "plot_spectrum": "motion_plot",
    "plot_staircase": "motion_plot",
    "plot_sweep": "chart_plot",
    "plot_velocity": "motion_plot",
    "plot_velocity_gap": "response_plot",
}

__all__ = list(_MODULES)

__getattr__, __dir__ = lazy_names(__name__, _MODULES)
