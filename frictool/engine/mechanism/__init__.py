"""Event-driven simulation of a mechanism of blocks with rigid links, friction and contacts."""
