"""Objects that scenes are composed of, and the paints of their surfaces; all numbers are chosen to look right."""
