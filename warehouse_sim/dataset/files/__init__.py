"""Single files, whatever they are of: how JSON, PNG, PLY and run lengths are written and read."""
