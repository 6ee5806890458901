"""Estimators of a user: a class, a function or a program."""
