"""Vehicles. Their noses look along -y.

Nobody can walk below a vehicle: its footprint is its whole outline.
"""
