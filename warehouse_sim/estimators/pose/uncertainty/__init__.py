"""What is thought of a pose after refinement: features, a covariance, a bound on its error, and the risk that it fails.

The estimator gives nothing but its poses; everything is looked up in the depth image and on the CAD surface.
"""
