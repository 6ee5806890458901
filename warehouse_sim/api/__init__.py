"""The front door in Python: it composes the stages, and ``warehouse_sim`` names what is public of it."""
