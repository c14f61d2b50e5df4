"""Bring-up: a rover that has just been built is measured step by step, and what is found goes into its vehicle file."""
