"""Hostile input: mutated recipes, objects, datasets, predictions, runs and command lines, and a judge of each."""
