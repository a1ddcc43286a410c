"""Verdicts on figures, and how measures and their figures are written for people."""

MET, SHORT, OPEN, SHOWN = "met", "short", "cannot be decided", "shown"
SCATTERS = "open"  # the figures scatter by more than the margin
TITLES = {
    "percent_above_0_5": "% > 0.5", "percent_above_0_6": "% > 0.6", "mean_quality": "mean", "min_dihedral_deg": "least angle",
    "p1_dihedral_deg": "1% angle", "p5_dihedral_deg": "5% angle", "max_dihedral_deg": "greatest angle",
    "p99_max_dihedral_deg": "99% greatest", "mean_mean_ratio": "mean ratio", "p5_mean_ratio": "mean ratio 5%",
    "mean_radius_ratio": "radius ratio", "p5_radius_ratio": "radius ratio 5%", "mean_edge_ratio": "edge ratio",
    "p5_edge_ratio": "edge ratio 5%", "p1_error": "P1 error", "p1_error_worst": "worst P1 error", "explicit_step": "explicit step",
    "stiffness_condition": "condition", "scaled_condition": "scaled condition", "max_stiffness_eigenvalue": "greatest eigenvalue",
    "max_scaled_eigenvalue": "greatest scaled eigenvalue", "surface_distance_upper": "distance", "boundary_bend_ratio": "bend",
    "kernel_s": "kernel, s", "peak_rss_bytes": "memory, bytes",
}
DIGITS = {
    "percent_above_0_5": 2, "percent_above_0_6": 2, "mean_quality": 4, "min_dihedral_deg": 2, "p1_dihedral_deg": 2, "p5_dihedral_deg": 2,
    "max_dihedral_deg": 2, "p99_max_dihedral_deg": 2, "mean_mean_ratio": 4, "p5_mean_ratio": 4, "mean_radius_ratio": 4,
    "p5_radius_ratio": 4, "mean_edge_ratio": 4, "p5_edge_ratio": 4, "p1_error": 4, "p1_error_worst": 4, "explicit_step": 4,
    "stiffness_condition": 0, "scaled_condition": 0, "max_stiffness_eigenvalue": 3, "max_scaled_eigenvalue": 3,
}


def amount(measure, value):
    """A difference or figure of a measure, with as many digits as it takes to tell it from zero."""
    digits = DIGITS.get(measure)
    if digits is None or (value and round(abs(value), digits) == 0):
        return f"{value:.2g}" if value else "0"
    return f"{value:.{digits}f}"
