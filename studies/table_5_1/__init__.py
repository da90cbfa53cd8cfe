"""The loops of the thesis's table 5.1: by hand, by the product, and as published."""
