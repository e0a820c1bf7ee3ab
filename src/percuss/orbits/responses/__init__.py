"""All families over a parameter: response charts and velocity-gap curves."""
