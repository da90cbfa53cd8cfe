
    blocks, kinds, start (n,): names, turning or sliding, positions [rad | m] at which every rigid link fits. joints ... sources: names of
    the elements in the order of the arrays. sensors: names; sensor_blocks: the block of each. groups: what moves as one. notes: what was
    left out or assumed, one line each.
    """

