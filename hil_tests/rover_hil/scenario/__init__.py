"""Fault scenarios: a language in TOML, what they put in, how they are run, judged and reported."""
