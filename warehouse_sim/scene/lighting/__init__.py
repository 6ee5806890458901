"""What a recipe says of light, the luminaires that stand for it, and the formulas between lumen, candela, lux and EV.

Nothing here needs rays: shadows, bounced light and what a camera meters are in ``generation.light``.
"""
