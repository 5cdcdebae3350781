ctypedef fused value:
    unsigned char
    unsigned short
    float
    double
