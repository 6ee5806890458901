"""Plug-ins for warehouse_sim by somebody else: one of each kind."""
