"""Clock offset and drift between instruments, gaps in time, and resampling to one grid."""
