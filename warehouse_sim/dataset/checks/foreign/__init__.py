"""What ``validate`` asks of a dataset that others made: whatever its format, through its reader."""
