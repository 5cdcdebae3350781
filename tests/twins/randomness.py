"""Random bits: a hash of a seed, a purpose and a place."""


def splitmix(state):
    """SplitMix64's step on Python's own integers (Steele, Lea and Flood, 2014)."""
    mask = 2**64 - 1
    state = (state + 0x9E3779B97F4A7C15) & mask
    state = ((state ^ (state >> 30)) * 0xBF58476D1CE4E5B9) & mask
    state = ((state ^ (state >> 27)) * 0x94D049BB133111EB) & mask
    return state ^ (state >> 31)


def random_bits(seed, purpose, *place):
    """The 64 bits of one place: seed, the purpose's bytes, 0xff and coordinates, mixed in turn."""
    state = splitmix(seed)
    for word in (*purpose.encode(), 0xFF, *place):
        state = splitmix(state ^ (int(word) & (2**64 - 1)))  # negative ones in two's complement
    return state
