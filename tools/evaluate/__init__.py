"""Measures the detector on what it has never seen: real zones and sessions in turn, synthetic soils and hours."""
