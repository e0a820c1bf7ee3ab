"""An independent reference: events of the general model in high-precision arithmetic."""
