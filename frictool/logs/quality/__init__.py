"""What the samples of a log say of the instruments that took them."""
