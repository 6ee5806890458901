"""Estimators of 6D poses, one method family a folder."""
