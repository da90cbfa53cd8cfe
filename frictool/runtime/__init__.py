"""Services for all packages: kernels, kernel cache, notifications, partial files, lazy exports."""
