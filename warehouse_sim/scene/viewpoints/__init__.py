"""Where cameras look from: single views and drives of vehicles, and free cameras, with their targets in view."""
