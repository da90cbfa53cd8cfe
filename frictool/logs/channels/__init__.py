"""What columns mean: from the columns of a bench file to channels in SI."""
