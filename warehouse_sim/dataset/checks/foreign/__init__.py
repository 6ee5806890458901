"""What ``validate`` asks of a third-party dataset: whatever its format, through its reader."""
