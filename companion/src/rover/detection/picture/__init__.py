"""Pictures that know neither kelvin nor metres: candidates and their descriptions."""
