"""The building around a layout: a hall to size, what hangs under its roof and on its walls, what lies on its floor."""
