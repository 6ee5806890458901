"""Unit loads and bare goods: how each is built up, where it stands, and what differs from carton to carton."""
