"""What trials say: pass rate, distributions, which factor failures and variance come from."""
