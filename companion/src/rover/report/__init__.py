"""What is left of a run for people: the result, the map as a picture and the report."""
