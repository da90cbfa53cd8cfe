"""Arrays and linearisation of mechanisms, which consist of blocks and links."""
