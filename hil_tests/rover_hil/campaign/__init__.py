"""Many missions, drawn from stated distributions: how often something goes wrong, with its bounds."""
