"""Dyskin, Pasternak & Pelinovsky (2012), recomputed and held against evidence."""
