"""Vehicles. Their noses look along -y.

The ground below a vehicle cannot be walked on: it takes its whole outline.
"""
