"""Pictures that are generated from their names: labels, prints on board, location labels.

A name is a kind and a key, "shipping_label:4711"; the same name is the same picture everywhere.
"""
