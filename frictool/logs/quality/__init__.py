"""Quality of a log's signals: instruments, signs, saturation, jumps and kind of test."""
