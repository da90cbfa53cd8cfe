"""What a bench can identify, before anything is measured on it (thesis 4.2.1-4.2.4, annex B)."""
